"""Compiled code: what is compiled (kernel, entry), how (compiler), where it is kept (store)."""
