"""Errors of requests that end without a mesh."""


class MeshgenError(Exception):
    """An error with a remedy: `error` states what is wrong and where, `hint` what to do about it."""

    exit_code = 3

    def __init__(self, error: str, hint: str = ""):
        super().__init__(error)
        self.error = error
        self.hint = hint

    def as_json(self) -> dict:
        return {"error": self.error, "hint": self.hint}


class BadRequest(MeshgenError):
    """The request is not valid: unknown key, impossible parameter, unreadable file."""

    exit_code = 2


class MesherFailed(MeshgenError):
    """The request is valid, but the mesher could not fulfil it."""

    exit_code = 3


class SizeNotReached(MesherFailed):
    """Meshes can be made, but none with the requested number of cells; `nearest` is the closest number of cells."""

    def __init__(self, error: str, hint: str, nearest: int):
        super().__init__(error, hint)
        self.nearest = nearest

    def as_json(self) -> dict:
        return super().as_json() | {"nearest": self.nearest}
