"""A value that lives in one record of a NumPy structured array.

Compiled kernels read and write such records without conversion; people read them by attribute.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray


class Record:
    """An immutable view on a structured array of shape (1,).

    Subclasses set `DTYPE` and annotate its fields. Scalars are read as numbers, vectors as
    read-only arrays. `Subclass.of(array)` wraps an array without a copy or a check.
    """

    __slots__ = ("array",)
    DTYPE: ClassVar[np.dtype[np.void]]
    array: NDArray[np.void]

    @classmethod
    def of(cls, array: NDArray[np.void]) -> Self:
        """The record around an array of `DTYPE`, shape (1,)."""
        record = _new(cls)
        set_array(record, array)
        return record

    def __getattr__(self, name: str) -> Any:
        if name not in (self.DTYPE.names or ()):
            raise AttributeError(f"{type(self).__name__} has no field {name!r}")
        value = self.array[name][0]
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
            return value
        return value.item()

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(
            f"{type(self).__name__} is a value: make another one with replace({name}=...)"
        )

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed."""
        array = copy_array(self.array)
        for name, value in changes.items():
            array[name] = value
        return type(self).of(array)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self.array.tobytes() == other.array.tobytes()  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return hash(self.array.tobytes())

    def __repr__(self) -> str:
        # As stored: a record with a broken field must still be able to show itself.
        values = zip(self.DTYPE.names or (), self.array[0].tolist(), strict=True)
        fields = ", ".join(f"{name}={value!r}" for name, value in values)
        return f"{type(self).__name__}({fields})"


set_array = Record.__dict__["array"].__set__
_new = object.__new__


def fill(record: Record, values: Mapping[str, Any]) -> None:
    """Give a new record its array, each field from the value of the same name."""
    array = new_array(record.DTYPE)
    for name in record.DTYPE.names or ():
        array[name][0] = values[name]
    set_array(record, array)


def new_array(dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """One record of zeros, shape (1,).

    Half the time of np.zeros, which goes through the fields of a structured dtype one by one.
    """
    return np.ndarray(1, dtype, bytearray(dtype.itemsize))


def copy_array(array: NDArray[np.void]) -> NDArray[np.void]:
    """A copy of one record; a tenth of the time of its method `copy`, which goes field by field."""
    return np.ndarray(1, array.dtype, bytearray(array.tobytes()))


def stack(arrays: Iterable[NDArray[np.void]], dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Arrays of one record as one array, shape (n,); read-only.

    A hundred times faster than np.concatenate, which promotes the dtypes field by field.
    """
    return np.frombuffer(b"".join(array.tobytes() for array in arrays), dtype)
