"""Fails unless two programs print the same lines.   same_output.py PROGRAM PROGRAM"""
import subprocess
import sys

outputs = [subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines()
           for program in sys.argv[1:]]
first, second = outputs
different = [f"{a}  |  {b}" for a, b in zip(first, second) if a != b]
print("\n".join(different) or f"{len(first)} lines, all the same")
sys.exit(bool(different) or len(first) != len(second) or not first)
