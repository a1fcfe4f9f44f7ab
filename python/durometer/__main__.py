"""`python -m durometer` and the script `durometer`: the command line."""

import signal
import sys

from . import _native


def run() -> int:
    """Runs the command line as a program of its own would: Ctrl-C ends it, where a command does not take it, and so does a closed pipe."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(sys.argv[1:], True)


if __name__ == "__main__":
    sys.exit(run())
