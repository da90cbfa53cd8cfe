"""Sources that the machine code of a kernel depends on: its module and all modules it imports.

Comments and docstrings are ignored. Imports are read from the syntax tree, also inside functions;
imports for type checkers are skipped. Some imports cannot be resolved from the tree: a star import,
a package used as a whole, a name that a package computes, a module imported by a computed name.
Such an import counts as an import of every module that it could mean. Other sources, such as those
of numpy and numba, belong to the toolchain and are not followed.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from frictool.runtime.module_source import ANALYSIS, ModuleSource, analyse

PACKAGE = Path(__file__).resolve().parents[1]
# module that imports by computed names; the names are read from literal tables of its callers
LAZY = "frictool.runtime.lazy_exports"
STORAGE = frozenset(  # modules that store machine code but generate none
    f"frictool.runtime.{name}"
    for name in (
        "deferred_imports",
        "kernel_folders",
        "kernel_sources",
        "machine_code_store",
        "module_source",
        "notifications",
    )
)
INSTALLED = {"site-packages", "dist-packages"}
MEMO = f"sources-{ANALYSIS}.json"
# largest number of sources in the memo; if there are more, those unused by this process are dropped
MOST = 2000
_START = time.time()


class UnknownSourcesError(Exception):
    """Error for a source that cannot be read, or has changed since its import."""


@dataclass(frozen=True)
class State:
    """Names of the modules on which machine code depends, and the digest of their sources."""

    modules: frozenset[str]
    digest: str


@dataclass(eq=False)
class Sources:
    """Sources of the modules of frictool, and of user modules in the folder `root`.

    package: folder of frictool.
    only: name of the package in `root` whose imports are followed; "" for all packages.
    memo: folder of a file that stores analysed sources for the next process; None for no file.
    """

    root: Path
    memo: Path | None = None
    package: Path = PACKAGE
    only: str = ""
    _paths: dict[str, Path | None] = field(default_factory=dict)
    _sources: dict[str, ModuleSource] = field(default_factory=dict)
    _edges: dict[str, frozenset[str]] = field(default_factory=dict)
    _states: dict[frozenset[str], State] = field(default_factory=dict)
    _stamps: dict[str, tuple[int, ...]] = field(default_factory=dict)
    _declared: dict[Path, tuple[int, ...]] = field(default_factory=dict)
    _known: dict[str, ModuleSource] | None = None
    _is_new: bool = False

    def declare(self, path: Path) -> None:
        """Record the time stamp of the module at `path`, which is being imported now."""
        if path not in self._declared:
            with suppress(UnknownSourcesError):
                self._declared[path] = _stamp(path)

    def state(self, modules: Iterable[str]) -> State:
        """Return the state of `modules` and all modules that they import, directly or indirectly.

        Raises UnknownSourcesError if a source cannot be read, or has changed since its import.
        """
        key = frozenset(modules)
        if key not in self._states:
            if missing := sorted(name for name in key if self._path(name) is None):
                raise UnknownSourcesError(f"the source of {missing[0]} is missing")
            self._states[key] = self._follow(key)
        for name in self._states[key].modules:
            if (path := self._path(name)) is not None and self._stamps[name] != _stamp(path):
                raise UnknownSourcesError(f"{path} was changed after it was read")
        return self._states[key]

    def _follow(self, modules: Iterable[str]) -> State:
        waiting = list(modules)
        reached = set()
        while waiting:
            name = waiting.pop()
            if name not in reached:
                reached.add(name)
                waiting += self._imported(name) - reached
        seen = hashlib.sha256()
        for name in sorted(reached):
            seen.update(
                f"{name} {self._source(name).digest if self._path(name) else ''}\n".encode()
            )
        if self._is_new:
            self._keep()
        return State(frozenset(reached), seen.hexdigest()[:16])

    def holds(self, name: str) -> bool:
        """Return True if the imports of the module or package `name` are followed."""
        if self.only and name.split(".")[0] not in ("frictool", self.only):
            return False
        return self._path(name) is not None or self._folder(name).is_dir()

    def everything(self, top: str = "frictool") -> frozenset[str]:
        """Return the names of all modules of a package."""
        folder = self._folder(top)
        reached = {top}
        for path in folder.rglob("*.py"):
            reached.add(
                ".".join((top, *path.relative_to(folder).with_suffix("").parts)).removesuffix(
                    ".__init__"
                )
            )
        return frozenset(reached)

    def _folder(self, name: str) -> Path:
        top, *rest = name.split(".")
        return (self.package if top == "frictool" else self.root / top).joinpath(*rest)

    def _path(self, name: str) -> Path | None:
        if name not in self._paths:
            folder = self._folder(name)
            both = (
                folder / "__init__.py",
                folder.with_suffix(".py") if "." not in folder.name else folder,
            )
            self._paths[name] = next((path for path in both if path.is_file()), None)
        return self._paths[name]

    def _imported(self, name: str) -> frozenset[str]:
        if name not in self._edges:
            parts = name.split(".")
            modules = {".".join(parts[:count]) for count in range(1, len(parts))}
            if self._path(name) is not None:
                source = self._source(name)
                if source.is_open and name != LAZY:
                    modules |= self.everything() | self.everything(parts[0])
                for one in source.imports:
                    modules |= self._meant(name, *one)
            self._edges[name] = frozenset(modules) - STORAGE
        return self._edges[name]

    def _meant(self, importer: str, level: int, module: str, name: str) -> frozenset[str]:
        base = self._absolute(importer, level, module)
        top = base.split(".")[0]
        if not self.holds(top):
            return frozenset()
        if not self.holds(base):
            return self.everything(top)
        if name in ("", "*"):
            return self._whole(base)
        if self.holds(f"{base}.{name}"):
            return self._whole(f"{base}.{name}")
        if not self._is_package(base):
            return frozenset({base})
        source = self._source(base) if self._path(base) else None
        if source is not None and name in source.table:
            module = f"{base}.{source.table[name]}"
            return frozenset({base, module}) if self.holds(module) else self.everything(top)
        if source is not None and name in source.names:
            return frozenset({base})
        return self.everything(top)

    def _absolute(self, importer: str, level: int, module: str) -> str:
        if level == 0:
            return module
        package = importer.split(".") if self._is_package(importer) else importer.split(".")[:-1]
        return ".".join([*package[: len(package) - level + 1], *([module] if module else [])])

    def _is_package(self, name: str) -> bool:
        return self._folder(name).is_dir()

    def _whole(self, name: str) -> frozenset[str]:
        """Return the module `name`, or all modules of the package `name`.

        Any module of a package may be an attribute of the package, because other code may have
        imported this module.
        """
        return self.everything(name) if self._is_package(name) else frozenset({name})

    def _source(self, name: str) -> ModuleSource:
        if name not in self._sources:
            path = self._path(name)
            assert path is not None
            stamp = _stamp(path)
            try:
                content = path.read_bytes()
            except OSError as error:
                raise UnknownSourcesError(str(error)) from None
            if not self._is_as_imported(name, path, stamp):
                raise UnknownSourcesError(f"{path} was changed after it was imported")
            self._sources[name] = self._analysed(content)
            self._stamps[name] = stamp
        return self._sources[name]

    def _is_as_imported(self, name: str, path: Path, stamp: tuple[int, ...]) -> bool:
        if path in self._declared:
            return self._declared[path] == stamp
        return name not in sys.modules or max(stamp[:2]) < _START * 1e9

    def _analysed(self, content: bytes) -> ModuleSource:
        key = hashlib.sha256(content).hexdigest()[:32]
        known = self._load()
        if key not in known:
            try:
                known[key] = analyse(content)
            except (SyntaxError, ValueError) as error:
                raise UnknownSourcesError(str(error)) from None
            self._is_new = True
        return known[key]

    def _load(self) -> dict[str, ModuleSource]:
        if self._known is None:
            self._known = {}
            with suppress(OSError, ValueError, TypeError, KeyError):
                read = json.loads((self.memo / MEMO).read_bytes()) if self.memo else {}
                self._known = {
                    key: ModuleSource(
                        digest,
                        tuple((i[0], i[1], i[2]) for i in imports),
                        frozenset(names),
                        dict(table),
                        is_open,
                    )
                    for key, (digest, imports, names, table, is_open) in read.items()
                }
        return self._known

    def _keep(self) -> None:
        self._is_new = False
        if self.memo is None:
            return
        known = self._load()
        used = {id(source) for source in self._sources.values()}
        rows = {
            key: [one.digest, one.imports, sorted(one.names), one.table, one.is_open]
            for key, one in known.items()
            if len(known) < MOST or id(one) in used
        }
        part = self.memo / f"{MEMO}.{os.getpid()}"
        with suppress(OSError):
            part.write_text(json.dumps(rows, separators=(",", ":")), encoding="utf-8")
            os.replace(part, self.memo / MEMO)


def _stamp(path: Path) -> tuple[int, ...]:
    try:
        status = os.stat(path)
    except OSError as error:
        raise UnknownSourcesError(str(error)) from None
    return status.st_mtime_ns, status.st_ctime_ns, status.st_size, status.st_ino
