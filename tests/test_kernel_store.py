"""Compiled kernels follow the sources that they depend on: what an edit compiles anew, and what it
leaves."""

from __future__ import annotations

import importlib
import math
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from numba.core.dispatcher import Dispatcher

from frictool.runtime import kernel_sources, kernels, machine_code_store
from frictool.runtime.kernel_folders import AGE_S, KEPT, prune_states
from frictool.runtime.kernel_sources import PACKAGE, Sources, UnknownSourcesError
from frictool.runtime.machine_code_store import reached, sources_of

PROGRAM = """
import sys
from numba.core import event
from frictool.runtime import kernels

class Names(event.Listener):
    def on_start(self, event):
        print(event.data["dispatcher"].py_func.__name__, end=" ")
    def on_end(self, event):
        pass

event.register("numba:compile", Names())
from rig import drive, alone
print(drive.power(3.0), alone.half(3.0))
"""
RIG = {
    "__init__.py": "",
    "limits.py": '"""Limits."""\nLIMIT = 2.0\n',
    "law.py": 'from frictool.runtime.kernels import kernel\n\n\n@kernel\ndef force(v):\n    """A '
    'force."""\n    return v\n',
    "drive.py": "from frictool.runtime.kernels import kernel\nfrom rig.law import force\nfrom . "
    "import limits\n\n\n"
    "LIMIT = limits.LIMIT\n\n\n@kernel\ndef power(v):\n    return LIMIT * force(v) * v\n",
    "alone.py": "from frictool.runtime.kernels import kernel\n\n\n@kernel\ndef half(v):\n    "
    "return 0.5 * v\n",
}

COMPILING_PARTS = ["numba.np.arrayobj", "numba.np.arraymath", "numba.core.typing.cffi_utils"]


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    """A package of two kernels, one of which calls a third, and a module of constants."""
    for name, text in RIG.items():
        (tmp_path / "rig").mkdir(exist_ok=True)
        (tmp_path / "rig" / name).write_text(text)
    return tmp_path / "rig"


def compiled(rig: Path, program: str = PROGRAM) -> list[str]:
    """Run the kernels in a new process; the names of those that it compiles, and their values."""
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(rig.parent / "kept"),
        "PYTHONPATH": f"{rig.parent}{os.pathsep}{PACKAGE.parent}",
    }
    # -B: Python takes stale bytecode for an edit within a second that keeps the length of the file
    words = [sys.executable, "-B", "-c", program]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=True)
    return done.stdout.split()


def replace(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_an_edit_compiles_the_kernels_that_depend_on_it(rig: Path) -> None:
    assert compiled(rig) == ["power", "force", "half", "18.0", "1.5"]
    replace(rig / "limits.py", "LIMIT = 2.0", "LIMIT = 4.0")
    assert compiled(rig) == ["power", "36.0", "1.5"]
    replace(rig / "limits.py", "LIMIT = 4.0", "LIMIT = 2.0")
    for path in rig.glob("*.py"):  # comments, lines, docstrings
        path.write_text(
            "# a comment\n\n"
            + path.read_text()
            .replace("A force.", "The force [N].")
            .replace("Limits.", "All limits.")
        )
    assert compiled(rig) == ["18.0", "1.5"]
    replace(rig / "law.py", "return v", "return v + 1.0")
    replace(rig / "alone.py", "\n\n@kernel", "from rig.limits import LIMIT\n\n@kernel")
    replace(rig / "alone.py", "0.5 *", "LIMIT *")
    assert compiled(rig) == ["power", "force", "half", "24.0", "6.0"]
    replace(rig / "limits.py", "LIMIT = 2.0", "LIMIT = 4.0")
    assert compiled(rig) == ["power", "half", "48.0", "12.0"]


def test_stored_kernels_run_without_the_parts_of_numba_that_compile(rig: Path) -> None:
    replace(rig / "alone.py", "import kernel\n", "import kernel\nimport numpy as np\n")
    replace(rig / "alone.py", "0.5 * v", "v - np.full(2, 0.25 * v).sum()")
    program = f"{PROGRAM}print(*(name for name in {COMPILING_PARTS} if name in sys.modules))"
    assert compiled(rig, program)[-5:] == ["18.0", "1.5", *COMPILING_PARTS]
    assert compiled(rig, program) == ["18.0", "1.5"]


def test_a_checkout_finds_the_kernels_of_another(
    rig: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    assert compiled(rig)[:3] == ["power", "force", "half"]
    other = tmp_path_factory.mktemp("other")
    (rig.parent / "kept").rename(other / "kept")
    rig.rename(other / "rig")
    assert compiled(other / "rig") == ["18.0", "1.5"]


def test_a_kernel_that_two_processes_need_is_compiled_once(rig: Path) -> None:
    """The second waits for the first, which takes a second over each."""
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(rig.parent / "kept"),
        "PYTHONPATH": f"{rig.parent}{os.pathsep}{PACKAGE.parent}",
    }
    slow = PROGRAM.replace("        pass", "        import time; time.sleep(1.0)")
    both = [
        subprocess.Popen(
            [sys.executable, "-c", slow], env=environment, stdout=subprocess.PIPE, text=True
        )
        for _ in range(2)
    ]
    words = [word for one in both for word in one.communicate()[0].split()]
    assert sorted(words) == sorted(["power", "force", "half", *["18.0", "1.5"] * 2])


SOURCES = {
    "__init__.py": (
        "from frictool.runtime.lazy_exports import lazy_exports\n"
        "from rig.near import near\n"
        "__getattr__, __dir__, __all__ = lazy_exports(__name__, {'far': ['far']})\n"
    ),
    "near.py": "near = 1\n",
    "far.py": "far = 1\n",
    "sub/__init__.py": "",
    "sub/deep.py": "deep = 1\n",
    "constants.py": "C = 1\n",
    "apart.py": "",
}
BASE = {
    "rig",
    "rig.near",
    "rig.kernel",
    "frictool",
    "frictool.runtime",
    "frictool.runtime.lazy_exports",
}
WHOLE = BASE | {"rig.far", "rig.sub", "rig.sub.deep", "rig.constants", "rig.apart"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("import math\nimport numpy as np\nfrom numba import types", BASE),
        ("from rig.constants import C", BASE | {"rig.constants"}),
        ("from rig import constants", BASE | {"rig.constants"}),
        ("from . import constants", BASE | {"rig.constants"}),
        ("from .constants import C as D", BASE | {"rig.constants"}),
        ("from .sub.deep import deep", BASE | {"rig.sub", "rig.sub.deep"}),
        ("import rig.sub.deep as deep", BASE | {"rig.sub", "rig.sub.deep"}),
        ("from rig import near", BASE),
        ("def f():\n    from rig.constants import C", BASE | {"rig.constants"}),
        (
            "try:\n    from rig.constants import C\nexcept ImportError:\n    C = 2",
            BASE | {"rig.constants"},
        ),
        (
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from rig.constants import C",
            BASE,
        ),
        (
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    pass\nelse:\n    from "
            "rig.constants import C",
            BASE | {"rig.constants"},
        ),
        ("from rig import far", BASE | {"rig.far"}),  # a lazy export
        ("from rig.constants import *", BASE | {"rig.constants"}),
        (
            "from rig import sub",
            BASE | {"rig.sub", "rig.sub.deep"},
        ),  # sub.deep is there if anybody has imported it
        ("import rig.constants", WHOLE),  # binds the package
        ("from rig import *", WHOLE),
        ("from rig import made_up", WHOLE),
        ("from rig.missing import C", WHOLE),
    ],
)
def test_imports_are_read_from_the_source(text: str, expected: set[str], tmp_path: Path) -> None:
    for name, source in {**SOURCES, "kernel.py": text}.items():
        path = tmp_path / "rig" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source)
    assert Sources(tmp_path).state(["rig.kernel"]).modules == expected


def test_an_import_by_a_computed_name_depends_on_everything(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_sources, "_START", math.inf)  # nothing here was imported
    package = tmp_path / "elsewhere" / "frictool"
    (package / "runtime").mkdir(parents=True)
    for name in (
        "__init__",
        "law",
        "runtime/__init__",
        "runtime/kernels",
        "runtime/machine_code_store",
    ):
        (package / f"{name}.py").write_text("")
    (tmp_path / "kernel.py").write_text(
        "import importlib\nlaw = importlib.import_module('frictool.' + NAME)\n"
    )
    (tmp_path / "apart.py").write_text("")
    state = Sources(tmp_path, package=package).state(["kernel"])
    assert state.modules == {
        "kernel",
        "frictool",
        "frictool.law",
        "frictool.runtime",
        "frictool.runtime.kernels",
    }  # not what keeps the code


def test_what_was_read_is_kept_and_damage_to_it_is_survived(tmp_path: Path) -> None:
    (tmp_path / "kernel.py").write_text("from frictool.friction.lugre import LUGRE\n")
    expected = Sources(tmp_path).state(["kernel"])
    assert Sources(tmp_path, tmp_path).state(["kernel"]) == expected
    (memo,) = tmp_path.glob("sources-*.json")
    assert Sources(tmp_path, tmp_path).state(["kernel"]) == expected
    memo.write_bytes(memo.read_bytes()[:100])
    assert Sources(tmp_path, tmp_path).state(["kernel"]) == expected


def test_a_source_that_changed_after_its_import_gives_no_state(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """This process runs the old form: its machine code must not be kept as that of the new one."""
    path = tmp_path / "changing.py"
    path.write_text("C = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    importlib.import_module("changing")
    monkeypatch.delitem(sys.modules, "changing")
    assert Sources(tmp_path).state(["changing"])
    importlib.import_module("changing")
    with pytest.raises(UnknownSourcesError, match="was changed after it was imported"):
        Sources(tmp_path).state(["changing"])
    monkeypatch.delitem(sys.modules, "changing")


def test_a_source_that_changes_after_it_was_read_gives_no_state(tmp_path: Path) -> None:
    """A module that is loaded again in the same process, as in a notebook, has machine code that no
    state names."""
    (tmp_path / "limits.py").write_text("C = 1\n")
    (tmp_path / "kernel.py").write_text("from limits import C\n")
    sources = Sources(tmp_path)
    assert sources.state(["kernel"]).modules == {"kernel", "limits"}
    (tmp_path / "limits.py").write_text("C = 2\n")
    with pytest.raises(UnknownSourcesError, match=r"limits\.py was changed after it was read"):
        sources.state(["kernel"])


def test_a_module_without_its_source_gives_no_state(tmp_path: Path) -> None:
    with pytest.raises(UnknownSourcesError, match="the source of kernel is missing"):
        Sources(tmp_path).state(["kernel"])


def all_kernels() -> list[Any]:
    """Every kernel of the package."""
    files = [path for path in PACKAGE.rglob("*.py") if "kernel\ndef " in path.read_text()]
    modules = [
        importlib.import_module(
            f"frictool.{'.'.join(path.relative_to(PACKAGE).with_suffix('').parts)}"
        )
        for path in files
    ]
    return [
        value
        for module in modules
        for value in vars(module).values()
        if isinstance(value, Dispatcher)
    ]


def test_every_function_that_a_kernel_calls_is_in_its_state() -> None:
    found = {kernel.py_func: kernel for kernel in all_kernels()}
    assert len(found) > 300
    calls = 0
    for function in found:
        sources = sources_of(
            kernels.FOLDER or Path(),
            machine_code_store.module_of(function),
            function.__code__.co_filename,
        )
        called = reached(function, sources.holds)
        calls += len(called)
        assert called <= sources.state([function.__module__]).modules, function
    assert calls > 1000


def test_no_kernel_of_the_package_depends_on_everything() -> None:
    sources = Sources(PACKAGE.parent)
    for module in {kernel.py_func.__module__ for kernel in all_kernels()}:
        assert len(sources.state([module]).modules) < 150, module


def test_former_states_of_a_module_go_but_for_the_last_ones(tmp_path: Path) -> None:
    day = 86400.0
    for module in ("engine.slip", "engine.slip_band"):
        for age in range(KEPT + 3):
            folder = tmp_path / f"{module}-{age:016x}"
            folder.mkdir()
            os.utime(folder, (time.time() - age * day,) * 2)
    current = tmp_path / f"engine.slip-{0:016x}"
    gone = prune_states(current)
    assert sorted(path.name for path in gone) == [
        f"engine.slip-{age:016x}" for age in (KEPT + 1, KEPT + 2)
    ]
    os.utime(tmp_path / f"engine.slip-{3:016x}", (time.time() - AGE_S - day,) * 2)
    assert [path.name for path in prune_states(current)] == [f"engine.slip-{3:016x}"]
    assert len(list(tmp_path.glob("engine.slip_band-*"))) == KEPT + 3
