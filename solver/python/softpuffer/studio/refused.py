"""What the studio does not do, and why."""


class Refused(Exception):
    """A request that is refused, with a status of HTTP and a message for the person."""

    def __init__(self, status: int, message: str):
        self.status = status
        super().__init__(message)
