"""Exceptions of vrda, raised by the extension module."""


class InputError(ValueError):
    """Input that is refused: a job, a file or an argument. str() is "FILE: FIELD: found X, wanted Y"."""

    file: str
    """File, or the function whose argument is refused."""
    field: str
    """Key, line or part of the file, or the argument; may be empty."""
    found: str
    wanted: str
    line: int
    """Line number in the file; 0 where unknown."""

    def __init__(self, message: str, file: str, field: str, found: str, wanted: str, line: int = 0) -> None:
        super().__init__(message, file, field, found, wanted, line)
        self.file, self.field, self.found, self.wanted, self.line = file, field, found, wanted, line

    def __str__(self) -> str:
        return str(self.args[0])


class InternalError(RuntimeError):
    """A defect of vrda: please report it with its message."""
