from typing import Any

# MuJoCo defines its names in compiled modules that type checkers cannot read.
def __getattr__(name: str) -> Any: ...
