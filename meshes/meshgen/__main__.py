"""`python -m meshgen < request.json`: one JSON manifest on stdout, progress on stderr. A request `{"convert": …}` converts a volume mesh.

Exit codes: 0 done, 2 bad request, 3 the mesher failed. `--doctor` lists installed and missing packages."""

import json
import os
import sys


def main() -> int:
    stdout = private_stdout()
    if sys.argv[1:] == ["--doctor"]:
        from .doctor import examine

        answer = examine()
        code = 0 if answer["ok"] else 3
    else:
        answer, code = serve(sys.stdin.read())
    with stdout:
        stdout.write(json.dumps(answer) + "\n")
    return code


def private_stdout():
    """Reserve stdout for the answer; output of libraries goes to stderr."""
    ours = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    return ours


def serve(text: str) -> tuple:
    """Answer one request: (manifest or error, exit code)."""
    from .errors import MesherFailed, MeshgenError

    try:
        try:
            from . import convert, request, run
        except (ImportError, OSError) as error:
            raise MesherFailed(f"the mesher is not installed: {error}", "python -m meshgen --doctor says what is missing") from error
        asked = request.conversion(text)
        return (convert.run(**asked) if asked else run.run(request.read(text))), 0
    except MeshgenError as error:
        return error.as_json(), error.exit_code
    except OSError as error:
        failure = MesherFailed(f"cannot write the mesh: {error}", "check the output folder and the free space")
        return failure.as_json(), failure.exit_code


if __name__ == "__main__":
    sys.exit(main())
