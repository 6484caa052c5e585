"""Machine code that is copied to memory as it is: sections of an object file, linked when they are compiled.

LLVM's linker would take a tenth of the processor time of a short run, most of it to load LLVM. Object files of Linux on
x86-64 contain few kinds of relocations (System V ABI, AMD64 supplement, 4.4.1), all relative to their own place, so
they are applied once. What is left for each process are the addresses of functions of the C library and of Python; a
call of one jumps through a slot of the image.
"""

import ctypes
import mmap
import platform
import struct
import sys

POSSIBLE = sys.platform == "linux" and platform.machine() == "x86_64"
HEADER, SECTION, SYMBOL, RELOCATION = map(struct.Struct, ("<40xQ10xHHH", "<IIQQQQIIQQ", "<IBBHQQ", "<QQq"))
PROGRAM, SYMBOLS, RELOCATIONS, ZEROS = 1, 2, 4, 8  # types of sections; others are for debuggers and linkers
LOADED = 2  # flag of a section
RELATIVE = 2, 4  # types of relocations: R_X86_64_PC32, R_X86_64_PLT32
JUMP = b"\xff\x25\0\0\0\0"  # jump to the address in the following slot of 8 bytes
ALIGNMENT = 64  # bytes


def linked(symbol: str, code: bytes) -> bytes | None:
    """Return the image of an object file: a line with the place of the function ``symbol`` and the slots, the bytes.

    Return None on other machines, or if the object file contains other relocations, which LLVM has to apply.
    """
    if not POSSIBLE:
        return None
    first, size, n, _ = HEADER.unpack_from(code)
    sections = [SECTION.unpack_from(code, first + i * size) for i in range(n)]
    image, places = bytearray(), {}
    for i, (_, kind, flags, _, at, size, _, _, alignment, _) in enumerate(sections):
        if kind in (PROGRAM, ZEROS) and flags & LOADED:
            image += bytes(-len(image) % alignment)
            places[i] = len(image)
            image += code[at : at + size] if kind == PROGRAM else bytes(size)
    ((_, _, _, _, at, size, strings, *_),) = (section for section in sections if section[1] == SYMBOLS)
    names, symbols = code[sections[strings][4] :], list(SYMBOL.iter_unpack(code[at : at + size]))
    slots: dict[str, int] = {}

    def place(number):
        name, _, _, section, value, _ = symbols[number]
        if section:
            return places[section] + value
        name = names[name : names.index(b"\0", name)].decode()
        if name not in slots:
            image.extend(JUMP + bytes(8))
            slots[name] = len(image) - 8
        return slots[name] - len(JUMP)

    for _, kind, _, _, at, size, _, of, *_ in sections:
        if kind == RELOCATIONS and of in places:
            for offset, information, addend in RELOCATION.iter_unpack(code[at : at + size]):
                if information & 0xFFFFFFFF not in RELATIVE:
                    return None
                here = places[of] + offset
                struct.pack_into("<i", image, here, place(information >> 32) + addend - here)
    entry = next(place(i) for i, one in enumerate(symbols) if names.startswith(symbol.encode() + b"\0", one[0]))
    return " ".join([str(entry), *(f"{name}:{at}" for name, at in slots.items())]).encode() + b"\n" + image


def is_image(content: bytes) -> bool:
    """Return whether the contents of a file of the store are an image, not an object file behind its symbol."""
    return content[:1].isdigit()


def load(images: list[bytes]) -> tuple[list[int], object]:
    """Copy images to executable memory; return the addresses of their functions, and what keeps the memory alive."""
    size = sum(len(one) + ALIGNMENT for one in images)
    memory = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    address, process = ctypes.addressof(ctypes.c_char.from_buffer(memory)), ctypes.CDLL(None, use_errno=True)
    at, found = 0, []
    for one in images:
        head, code = one.split(b"\n", 1)
        entry, *slots = head.decode().split()
        memory[at : at + len(code)] = code
        found.append(address + at + int(entry))
        for name, _, slot in (text.partition(":") for text in slots):
            function = ctypes.cast(getattr(process, name), ctypes.c_void_p).value
            struct.pack_into("<Q", memory, at + int(slot), function)
        at += len(code) + -len(code) % ALIGNMENT
    if process.mprotect(ctypes.c_void_p(address), ctypes.c_size_t(size), mmap.PROT_READ | mmap.PROT_EXEC):
        raise OSError(ctypes.get_errno(), "machine code cannot be executed")
    return found, memory
