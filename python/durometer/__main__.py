"""`python -m durometer` and the script `durometer`: the command line."""

import signal
import sys

from . import _native


def run() -> int:
    """Runs the command line as a standalone program: Ctrl-C ends it, unless a command handles it, and so does a closed pipe."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(sys.argv[1:], True)


if __name__ == "__main__":
    sys.exit(run())
