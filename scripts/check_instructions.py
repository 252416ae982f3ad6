#!/usr/bin/env python3
"""Finds code for newer processors under names that sources for older ones share.

    check_instructions.py BASELINE.o OBJECT...

The linker keeps one copy of an inline function for the whole program. So every function of the objects that uses
instructions beyond x86-64's own must have Highway's namespace for its target, N_AVX2 or N_AVX3, in its name. Prints
those that do not, and fails. Where BASELINE.o, compiled by the compiler's own options, has such instructions too,
there is nothing to be told apart: SKIPPED.
"""
import os
import re
import subprocess
import sys

function_start = re.compile(r"^[0-9a-f]+ <(.*)>:$")
# AVX and AVX-512 (by mnemonic or register), BMI1, BMI2, and what SSE4.2 brings to integers.
newer = re.compile(
    r"\t(v(?!er[rw]\b)[a-z]\w*|andn|bextr|bls\w+|bzhi|mulx|pdep|pext|rorx|sarx|shlx|shrx|popcnt|lzcnt|movbe|crc32\w*)\b"
    r"|%[yz]mm\d|%k[0-7]")
of_a_target = re.compile(r"(?<![A-Za-z_])N_AVX[23]")  # also where objdump leaves a name as it is


def functions_with_newer_instructions(path):
    """Demangled name -> the first such instruction."""
    objdump = os.environ.get("OBJDUMP", "objdump")
    listing = subprocess.run([objdump, "--disassemble", "--demangle", "--no-show-raw-insn", path],
                             check=True, capture_output=True, text=True).stdout
    found, function = {}, None
    for line in listing.splitlines():
        if start := function_start.match(line):
            function = start[1]
        elif newer.search(line):
            found.setdefault(function, line.split("\t", 1)[1])
    return found


def main(baseline, *objects):
    if functions_with_newer_instructions(baseline):
        print("SKIPPED: the compiler's own options allow AVX")
        return 0
    used, shared = 0, 0
    for path in objects:
        for function, instruction in functions_with_newer_instructions(path).items():
            used += 1
            if not of_a_target.search(function):
                shared += 1
                print(f"{path}: {function} is not in a target's namespace and uses {instruction}")
    if not used:
        print("no function uses newer instructions: were these objects compiled for a target?")
    return 1 if shared or not used else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
