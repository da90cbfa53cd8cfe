"""List of names for a message, shortened to a given length."""

from __future__ import annotations

from collections.abc import Collection

MOST_NAMES_SHOWN = 12
LONGEST_LIST = 120  # maximum number of characters of a list of names in a message


def listed(names: Collection[str], longest: int = LONGEST_LIST, separator: str = ", ") -> str:
    """Return names as text; an empty name is shown in quotes.

    At most MOST_NAMES_SHOWN names are shown, and only as many as fit into about `longest`
    characters, but at least one. The number of names that are left out is appended.
    """
    shown: list[str] = []
    for name in names:
        if len(shown) == MOST_NAMES_SHOWN or (
            shown and len(separator.join(shown)) + len(name) > longest
        ):
            break
        shown.append(name or "''")
    return (
        separator.join(shown)
        + (f" and {len(names) - len(shown)} more" if len(names) > len(shown) else "")
        if shown
        else "nothing"
    )
