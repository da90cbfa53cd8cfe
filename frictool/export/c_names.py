"""C names of a program's values, in one namespace for constants, inputs and results.

A node of the program is an input, a constant, a state or an operation (control/program.py).

    a[1][0]       an element of the constant array `a`
    x[0]          an element of the array `x` in the state
    band          a single constant
    mode          a field of the state

A name that C, its library or a helper function uses gets the suffix `_`. A second value with an
equal name gets the suffix `_2`.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product

from frictool.control.program import Program, ProgramNode

Index = tuple[int, ...]
RESERVED = """
auto break case char const continue default do double else enum extern float for goto if
inline int long register restrict return short signed sizeof static struct switch typedef union
unsigned void volatile while asm bool true false
sqrt sqrtf gamma index round signal time remove
main state value on disabled holding
is_valid absolute smaller larger bounded shifted raised word whole_root
"""
TAKEN = frozenset(re.findall(r"\w+", RESERVED))


@dataclass(frozen=True)
class NamedArray:
    """C variable of a constant or a state: name, shape (() for a scalar), node of each element."""

    name: str
    shape: Index
    nodes: dict[Index, ProgramNode]

    @property
    def brackets(self) -> str:
        """Return the dimensions of a declaration, such as `[2][3]`."""
        return "".join(f"[{size}]" for size in self.shape)

    def elements(self) -> list[tuple[Index, ProgramNode | None]]:
        """Return every index in row-major order, with the node at this index or None."""
        return [(index, self.nodes.get(index)) for index in product(*map(range, self.shape))]


class CNames:
    """C names of the values that a program uses.

    `text`: names of constants, inputs and states, by the number of the node.
    `results`: names of the results of operations, by the number of the node.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self.uses = _uses(program)
        self.taken: set[str] = set(TAKEN)
        self.text: dict[int, str] = {}
        self.results: dict[int, str] = {}
        for name, node in program.inputs.items():
            self.text[node.index] = self._free(name)
        coefficients = [
            node for node in program.nodes if node.op == "constant" and node.index in program.names
        ]
        used = {
            _split(program.names[node.index])[0] for node in coefficients if self.uses[node.index]
        }
        # declare every element of a used array, but only the used scalars
        arrays = [
            node
            for node in coefficients
            if "[" in program.names[node.index] and _split(program.names[node.index])[0] in used
        ]
        singles = [
            node
            for node in coefficients
            if "[" not in program.names[node.index] and self.uses[node.index]
        ]
        constants = sorted([*arrays, *singles], key=lambda node: node.index)
        self.constants = _tables(constants, program, self._free)
        self.states = _tables(program.states.values(), program, str)
        for table, where in [
            *((one, "") for one in self.constants),
            *((one, "state->") for one in self.states),
        ]:
            for index, node in table.nodes.items():
                self.text[node.index] = f"{where}{table.name}" + "".join(f"[{k}]" for k in index)
        self._name_results()

    def _name_results(self) -> None:
        """Give a C name to each operation whose result needs a variable.

        A result needs a variable if it has a name in the program, is used more than once, or
        becomes a state.
        """
        program = self.program
        becomes = {
            source.index: program.names[state]
            for state, source in reversed(program.updates.items())
        }
        for node in program.nodes:
            if node.op in ("constant", "input", "state") or not self.uses[node.index]:
                continue
            name = program.names.get(node.index)
            if name is None and node.index in becomes:
                name = f"next_{becomes[node.index]}"
            if name is None and self.uses[node.index] > 1:
                name = f"value_{node.index}"
            if name is not None:
                self.results[node.index] = self._free(name)

    def _free(self, name: str) -> str:
        word = re.sub(r"\W+", "_", name).strip("_")
        candidate = word if word not in TAKEN else f"{word}_"
        count = 1
        while candidate in self.taken:
            count += 1
            candidate = f"{word}_{count}"
        self.taken.add(candidate)
        return candidate


def _split(name: str) -> tuple[str, Index]:
    """Return base and index of a name: ("a", (1, 0)) for `a[1][0]`."""
    base, *rest = name.split("[")
    return base, tuple(int(part.rstrip("]")) for part in rest)


def _tables(
    nodes: Iterable[ProgramNode], program: Program, free: Callable[[str], str]
) -> list[NamedArray]:
    """Return the scalars and arrays of the nodes; `free` converts a node's name to a C name.

    Nodes whose names differ only in the index are elements of one array. Each node without an index
    is a scalar, even if another node has the same name.
    """
    groups: dict[tuple[str, int], dict[Index, ProgramNode]] = {}
    for node in nodes:
        base, index = _split(program.names[node.index])
        groups.setdefault((base, 0 if index else node.index), {})[index] = node
    tables = []
    for (base, _), members in groups.items():
        shape = tuple(
            max(index[k] for index in members) + 1 for k in range(len(next(iter(members))))
        )
        tables.append(NamedArray(free(base), shape, members))
    return tables


def _uses(program: Program) -> Counter[int]:
    assert program.output is not None
    uses: Counter[int] = Counter(
        [program.output.index, *(source.index for source in program.updates.values())]
    )
    for node in reversed(program.nodes):
        if uses[node.index]:
            uses.update(arg.index for arg in node.args)
    return uses
