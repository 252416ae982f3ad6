#!/usr/bin/env python3
"""Keeps README.md true.

    readme.py write TABLE.md   puts the demo's table between its markers, and the program from examples/first_light.cpp
    readme.py check            fails where the program in README.md is not examples/first_light.cpp
"""
import pathlib
import re
import sys

root = pathlib.Path(__file__).resolve().parent.parent
readme = root / "README.md"


def between(name, text, new):
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)", re.S)
    if not pattern.search(text):
        sys.exit(f"README.md: no markers for '{name}'")
    return pattern.sub(lambda found: found[1] + new + found[2], text)


def with_program(text):
    return between("program", text, "```cpp\n" + (root / "examples/first_light.cpp").read_text() + "```\n")


def main(arguments):
    text = readme.read_text()
    if arguments[:1] == ["write"] and len(arguments) == 2:
        table = pathlib.Path(arguments[1]).read_text()
        readme.write_text(with_program(between("table", text, table)))
    elif arguments == ["check"]:
        if with_program(text) != text:
            sys.exit("README.md: the program differs from examples/first_light.cpp; run scripts/readme.py write")
    else:
        sys.exit(__doc__)


main(sys.argv[1:])
