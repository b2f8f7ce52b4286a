"""A value that lives in one record of a NumPy structured array, and is declared field by field.

Compiled kernels read and write such records without conversion; people read them by attribute:

    class Landing(Record):
        \"\"\"A step that has ended.\"\"\"

        time: float = field("s", "time of the touchdown")
        offset: Vector2 = field("m", "DCM relative to the foot that has landed (x, y)")
        adapted: bool = field("", "whether the step was not the nominal one", default=False)

The one line of a field gives the dtype `Landing.DTYPE` that kernels are compiled for, in the order
of the lines, the keyword of `Landing(time=..., offset=...)`, the type that `landing.time` has for a
type checker, and the line in the docstring. A kernel knows no classes: where one makes a record it
needs the dtype under a name of its own, `LANDING = Landing.DTYPE`.
"""

from __future__ import annotations

import textwrap
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from inspect import Parameter, Signature, cleandoc
from operator import itemgetter
from typing import Annotated, Any, ClassVar, Self, dataclass_transform

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surefoot.errors import ParameterError

REQUIRED: Any = Parameter.empty
"""The default of a field that has none: its keyword cannot be left out."""


class Array:
    """The type of a field that holds several numbers or records: `shape` says how many."""

    def __get__(self, owner: object, kind: Any) -> NDArray[Any]:
        raise NotImplementedError("every field of a record is read by a property of its own")

    def __set__(self, owner: object, value: ArrayLike) -> None:
        raise NotImplementedError("a record is a value")


Vector2 = Annotated[Array, (2,)]
"""The type of a field with two numbers (x, y)."""

Vector3 = Annotated[Array, (3,)]
"""The type of a field with three numbers (x, y, z)."""


@dataclass(frozen=True)
class Field:
    """What a record says about one of its values; made by `field`."""

    unit: str
    words: str
    default: Any
    shape: tuple[int, ...]
    kind: Any

    def annotated(self, name: str, annotation: Any) -> Field:
        """The field with the kind and the shape of its annotation."""
        if annotation is Array:
            return self
        if typing.get_origin(annotation) is Annotated:
            return replace(self, shape=annotation.__metadata__[0])
        if not isinstance(annotation, type):
            raise ParameterError(
                f"an annotation of the field `{name}`",
                repr(annotation),
                "write float, int, bool, an enumeration, a class of records, or an Array",
            )
        return replace(self, kind=annotation)

    @property
    def format(self) -> Any:
        """How one value is stored."""
        if issubclass(self.kind, Record):
            return self.kind.DTYPE
        return {float: "f8", bool: "?"}.get(self.kind, "i8")

    def reader(self, name: str) -> Callable[[Record], Any]:
        """The function that reads the field of a record."""
        kind = self.kind

        def several(record: Record) -> NDArray[Any]:
            value = record.array[name][0]
            value.setflags(write=False)
            return value

        if self.shape:
            return several
        if issubclass(kind, Record):
            return lambda record: kind.of(record.array[name])
        if kind in (float, int, bool):
            return lambda record: record.array[name].item()
        return lambda record: kind(record.array[name].item())

    def documented(self, name: str) -> str:
        """The field's line in the docstring of its record."""
        unit = f" [{self.unit}]" if self.unit else ""
        line = f"{name}: {self.words}{unit}."
        return textwrap.fill(line, 100, initial_indent=" " * 4, subsequent_indent=" " * 8)


def field(
    unit: str,
    words: str,
    *,
    default: Any = REQUIRED,
    shape: int | tuple[int, ...] = (),
    kind: Any = float,
) -> Any:
    """Declare a field of a record.

    Args:
        unit: SI, as in docstrings; "-" for a number without one, "" for what is no quantity.
        words: what it is, for the docstring.
        default: for a keyword that may be left out.
        shape: of an `Array`.
        kind: of what an `Array` holds: `float`, `int`, `bool`, or another class of records.
    """
    return Field(unit, words, default, (shape,) if isinstance(shape, int) else shape, kind)


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(field,))
class Record:
    """An immutable view on a structured array of shape (1,).

    Subclasses declare one `field` a line, see above. Their annotation is `float`, `int`, `bool`, an
    enumeration, `Vector2`, `Vector3` or `Array`, or another class of records. Numbers are read as
    numbers, several of them as a read-only array, a record as a record. A subclass of a subclass
    has its own fields, then those of its parent. `Subclass.of(array)` wraps an array without a copy
    or a check.
    """

    __slots__ = ("array",)
    FIELDS: ClassVar[Mapping[str, Field]] = {}
    DTYPE: ClassVar[np.dtype[np.void]]
    _DEFAULTS: ClassVar[Mapping[str, Any]] = {}
    _NESTS: ClassVar[bool]
    _ROW: ClassVar[Any]
    __signature__: ClassVar[Signature]
    array: NDArray[np.void]

    def __init_subclass__(cls) -> None:
        hints = typing.get_type_hints(cls, include_extras=True)
        own = {name: it for name, it in vars(cls).items() if isinstance(it, Field)}
        typed = {name: it.annotated(name, hints.get(name)) for name, it in own.items()}
        # Own fields first: Numba takes a record that another one begins with for the same.
        cls.FIELDS = {**typed, **cls.FIELDS}
        cls.DTYPE = np.dtype([(name, it.format, it.shape) for name, it in cls.FIELDS.items()])
        cls._DEFAULTS = {
            name: it.default for name, it in cls.FIELDS.items() if it.default is not REQUIRED
        }
        cls._ROW = staticmethod(_values_of(tuple(cls.FIELDS)))
        cls._NESTS = any(issubclass(it.kind, Record) for it in cls.FIELDS.values())
        cls.__signature__ = Signature(
            [
                Parameter(name, Parameter.KEYWORD_ONLY, default=it.default)
                for name, it in cls.FIELDS.items()
            ]
        )
        first, raises, rest = cleandoc(cls.__doc__ or "").partition("Raises:")
        lines = [it.documented(name) for name, it in cls.FIELDS.items()]
        cls.__doc__ = "\n".join([first.rstrip(), "", "Args:", *lines, "", raises + rest]).rstrip()
        for name, it in cls.FIELDS.items():
            setattr(cls, name, property(it.reader(name), doc=it.words))

    def __init__(self, **values: Any) -> None:
        given = {**self._DEFAULTS, **values}
        try:
            row = self._ROW(given)
        except KeyError:
            row = ()
        if len(row) != len(given):
            # Says which keyword is missing or unknown.
            self.__signature__.bind(**values)
        set_array(self, self._made_of(row))

    @classmethod
    def _made_of(cls, row: tuple[Any, ...]) -> NDArray[np.void]:
        """The array of a new record, from its values in the order of the fields."""
        array = new_array(cls.DTYPE)
        array[0] = tuple([_plain(value) for value in row]) if cls._NESTS else row
        return array

    @classmethod
    def of(cls, array: NDArray[np.void]) -> Self:
        """The record around an array of `DTYPE`, shape (1,)."""
        record = _new(cls)
        set_array(record, array)
        return record

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(
            f"{type(self).__name__} is a value: make another one with replace({name}=...)"
        )

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed."""
        array = copy_array(self.array)
        for name, value in changes.items():
            array[name] = _plain(value)
        return type(self).of(array)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self.array.tobytes() == other.array.tobytes()  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return hash(self.array.tobytes())

    def __repr__(self) -> str:
        # As stored: a record with a broken field must still be able to show itself.
        values = zip(self.FIELDS, self.array[0].tolist(), strict=True)
        fields = ", ".join(f"{name}={value!r}" for name, value in values)
        return f"{type(self).__name__}({fields})"


set_array = Record.__dict__["array"].__set__
_new = object.__new__


def _values_of(names: tuple[str, ...]) -> Callable[[Mapping[str, Any]], tuple[Any, ...]]:
    """A function that takes these values out of a table; fast, where there are several."""
    if len(names) > 1:
        return itemgetter(*names)
    return lambda given: tuple(given[name] for name in names)


def _plain(value: Any) -> Any:
    """What NumPy can put into a field."""
    return value.array if isinstance(value, Record) else value


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
