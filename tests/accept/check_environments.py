"""The whole chain with the lowest and the newest versions of all dependencies; `make test-envs` has
other processors too."""

from __future__ import annotations

from tests.envs.dependencies import ENVIRONMENTS

CHECKS = {
    f"environments: {name} versions of all dependencies": check
    for name, check in ENVIRONMENTS.items()
}
