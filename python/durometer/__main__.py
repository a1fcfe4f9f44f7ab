"""`python -m durometer` and the script `durometer`: the command line."""

import signal
import sys

from . import main


def run() -> int:
    """Runs the command line as a program of its own would: Ctrl-C ends it, where a command does not take it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return main()


if __name__ == "__main__":
    sys.exit(run())
