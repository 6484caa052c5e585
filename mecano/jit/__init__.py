"""Compiled code: kernels and entries (kernel, entry), the compiler (compiler), the cache on disk (store)."""
