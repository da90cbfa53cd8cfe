"""`frictool completion`: shell completion of commands, options, choices and files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click
from click.shell_completion import get_completion_class

from frictool.cli.common_options import json_option, output_option
from frictool.cli.console_output import print_json
from frictool.cli.output_files import STDOUT, save_text

PROGRAM, VARIABLE = "frictool", "_FRICTOOL_COMPLETE"
# shell -> line for permanent installation
INSTALL = {
    "bash": "echo 'eval \"$(frictool completion bash)\"' >> ~/.bashrc",
    "zsh": "echo 'eval \"$(frictool completion zsh)\"' >> ~/.zshrc",
    "fish": "frictool completion fish -o ~/.config/fish/completions/frictool.fish",
}

HELP = f"""\b
Example:
  eval "$(frictool completion bash)"

Print the script with which a shell completes commands, options, choices and file names of frictool.
The example changes the current shell only. For every new shell, run once:

\b
{chr(10).join(f"  {shell:<6}{line}" for shell, line in INSTALL.items())}

bash must be 4.4 or later. In ~/.zshrc, compinit must run before this line.
"""


@click.command("completion", help=HELP)
@click.argument(
    "shell",
    type=click.Choice(list(INSTALL)),
    required=False,
    help="Shell. [default: from the variable SHELL]",
)
@output_option(required=False, writes=("text", "Markdown"))
@json_option
def command(shell: str | None, output: Path | None, as_json: bool) -> None:
    shell = shell or Path(os.environ.get("SHELL", "")).name
    if shell not in INSTALL:
        raise click.UsageError(
            f"the variable SHELL names no supported shell; give the shell: {', '.join(INSTALL)}."
        )
    text = (
        f"# Completion of frictool for {shell}. For every new shell: "
        f"{INSTALL[shell]}\n{script(shell)}"
    )
    if output is not None or not as_json:
        save_text(output or STDOUT, text, [])
    if as_json:
        print_json(
            "completion/1", {"shell": shell, "install": INSTALL[shell], "script": text}, output
        )


def script(shell: str) -> str:
    """Return the script that adds completion of frictool commands to a shell.

    The script calls frictool with the environment variable VARIABLE set.
    """
    kind: Any = get_completion_class(shell)
    asking = kind(click.Command(PROGRAM), {}, PROGRAM, VARIABLE)
    # source() of click would start a bash to query its version
    return f"{asking.source_template % asking.source_vars()}\n"
