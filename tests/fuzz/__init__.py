"""Mutated logs and documents through the whole program, `make fuzz`: no traceback, no hang, no
memory, no partial output.

samples.py     a small good file of each format, and a bench that maps its columns
mutations.py   a file with bytes and cells changed, from a seed
child.py       runs mutated inputs one after the other, in a process with limits
__main__.py    hands them out, restarts a process that died, tells what was found
"""
