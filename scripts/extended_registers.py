#!/usr/bin/env python3
"""Looks for instructions that LLVM 22 gives a wrong register (run by hand, on programs built for AVX-512).

    scripts/extended_registers.py [PROGRAM]...

The pass that compresses EVEX turns `vpmovd2m k, xmmN; kmov r, k` into `vmovmskps r, xmmN` for N above 15 too, which that instruction can't
name: it reads xmm(N - 16) (https://github.com/llvm/llvm-project/issues/191304). Where the register that is read was written longer ago
than its twin above 15, this happened. Exit code 1 if it did. Needs binutils' objdump.
"""
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MASK = re.compile(r"v?p?movmsk(ps|pd|b)\b")
REGISTER = re.compile(r"%[xyz]mm(\d+)")


def written(instruction):
    """The number of the vector register that an instruction writes: its last operand."""
    operand = re.sub(r"\{[^}]*\}", "", instruction).split(",")[-1].split()
    found = REGISTER.fullmatch(operand[-1]) if operand else None
    return int(found[1]) if found else None


def faults(program):
    """Functions and addresses of such instructions, and how many there are of the kind."""
    command = ["objdump", "-d", "--no-show-raw-insn", "-C", program]
    found, count, function, since = [], 0, "", {}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as dump:
        for number, line in enumerate(dump.stdout):
            if header := re.match(r"[0-9a-f]+ <(.*)>:$", line):
                function, since = header[1], {}
                continue
            fields = line.rstrip().split("\t")
            if len(fields) < 2:
                continue
            instruction = fields[-1].split("#")[0].strip()
            if MASK.match(instruction):
                count += 1
                read = int(REGISTER.search(instruction)[1])
                if since.get(read + 16, -1) > since.get(read, -1):
                    found.append((function, fields[0].strip(), instruction))
            elif (register := written(instruction)) is not None:
                since[register] = number
    return found, count


def main():
    wrong = False
    for program in sys.argv[1:] or [os.path.join(ROOT, "target", "release", "kaustika")]:
        found, count = faults(program)
        wrong |= bool(found)
        print(f"{program}: {count} moves of masks, {len(found)} of a wrong register")
        for function, address, instruction in found:
            print(f"  {function} {address} {instruction}")
    sys.exit(wrong)


if __name__ == "__main__":
    main()
