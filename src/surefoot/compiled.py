"""Compile kernels with Numba, once per machine and version of ALL of Surefoot's sources.

Numba keeps compiled code on disk and throws it away when the file that defines the function
changes. But a kernel has the functions that it calls compiled into it, and these live in other
files. So every kernel's cache is stamped with the content of all of them instead: edit any file,
and what may depend on it is compiled anew.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any

import numba
from numba.core.ccallback import CFunc

from surefoot.plugins import PACKAGE, content, foreign_stamp

NOT_COMPILED = {
    "__init__.py", "checks.py", "cli", "conformance.py", "errors.py", "live", "options.py",
    "plugins.py", "show", "studies", "version.py",
}  # fmt: skip
"""What no kernel is made of: what only fails, lists or shows. All else counts, what is new too."""


@cache
def source_stamp() -> str:
    """The content of every source file of Surefoot that kernels can be made of, as a hash."""
    sources = (path for path in PACKAGE.iterdir() if path.is_dir() or path.suffix == ".py")
    return content(PACKAGE, sorted(path for path in sources if path.name not in NOT_COMPILED))


def njit(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """`numba.njit` with a cache that knows all of the package; without the interpreter lock.

    The cache of a function of another package knows all of that package too.

    Args:
        function: what to compile, when it is used without options.
        **options: of `numba.njit`.
    """
    if function is None:
        return lambda function: njit(function, **options)
    dispatcher = numba.njit(cache=True, nogil=True, error_model="numpy", **options)(function)
    _stamp(dispatcher)
    return dispatcher


def entry_point(kernel: Any, *dtypes: Any) -> Callable[..., None]:
    """A compiled kernel for arrays of these records, called without a check of their types.

    The check takes longer than most kernels. An array with records of another size is refused all
    the same, with a TypeError.

    Args:
        kernel: made by `njit`.
        *dtypes: of the arrays that it is called with, one for each argument, or their classes of
            records; or Numba's type of an argument that is none of these, such as
            `numba.float64[:, ::1]`.
    """
    signature = tuple(
        kind
        if isinstance(kind, numba.types.Type)
        else numba.types.Array(numba.from_dtype(getattr(kind, "DTYPE", kind)), 1, "C")
        for kind in dtypes
    )
    kernel.compile(signature)
    return kernel.overloads[signature].entry_point


def record_entry_point(kernel: Any, *kinds: Any) -> Callable[..., None]:
    """`entry_point` of a kernel over records: it is called with arrays of one record each."""
    return entry_point(over_arrays(kernel), *kinds)


def over_arrays(kernel: Any) -> Any:
    """A kernel over records, made by `njit`, as one over arrays of one record each."""
    function = kernel.py_func
    names = tuple(inspect.signature(function).parameters)
    name = f"{function.__name__}_over_arrays"
    source = f"def {name}({', '.join(names)}):\n    kernel({'[0], '.join(names)}[0])\n"
    scope = {"__name__": function.__module__, "kernel": kernel}
    # Under the file of the kernel, beside which Numba keeps its cache.
    exec(compile(source, function.__code__.co_filename, "exec"), scope)
    return njit(scope[name])


def function_pointer(kernel: Any, signature: Any) -> CFunc:
    """A kernel as a pointer to compiled code, which another kernel takes as an argument.

    Its type is its signature, so the kernel that takes it is compiled once for all of its kind.

    Args:
        kernel: made by `njit`.
        signature: Numba types of arguments and result.
    """
    pointer = CFunc(kernel.py_func, ((*signature.args,), signature.return_type), {}, {})
    pointer.enable_caching()
    _stamp(pointer)
    pointer.compile()
    return pointer


def _stamp(compiled: Any) -> None:
    # Numba has no public way to widen what invalidates a cache.
    own = foreign_stamp(compiled._cache._py_func.__code__.co_filename)
    compiled._cache._cache_file._source_stamp = source_stamp() + own
