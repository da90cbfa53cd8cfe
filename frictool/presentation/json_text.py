"""JSON objects as text; the first key names the format, and null replaces non-finite values."""

from __future__ import annotations

import json
import math
from typing import Any


def json_text(form: str, value: dict[str, Any]) -> str:
    """Return the object as indented JSON, with the format as its first key.

    `form`: name and version of the format. Numbers that are not finite become null.
    """
    return json.dumps(finite({"format": form, **value}), indent=2, ensure_ascii=False)


def finite(value: Any) -> Any:
    """Return the value with None in place of each number that is not finite."""
    if isinstance(value, dict):
        return {str(key): finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
