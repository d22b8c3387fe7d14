# Only what the package shows: the Python code beside the module has the types of everything else.
from typing import Any

__version__: str

class Error(ValueError):
    code: str
    where: str
    problem: str
    remedy: str

def __getattr__(name: str) -> Any: ...
