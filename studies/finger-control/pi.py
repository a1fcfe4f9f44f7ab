"""PI control of a recorded column by one signal, over JSON lines: u = kp e + ki ∫ e dt, e = goal - column.

python3 pi.py GOAL [--column bending_angle_deg] [--kp 2.5e-5] [--ki 1e-3] [--most 0.02]

Units are those of the recorded column and SI for the signal. The integral is handed back in every answer as memory,
so a run that goes on from a saved state goes on with the same controller.
"""

import argparse
import json
import sys


def answer(**keys):
    print(json.dumps(keys), flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("goal", type=float)
    parser.add_argument("--column", default="bending_angle_deg")
    parser.add_argument("--kp", type=float, default=2.5e-5)
    parser.add_argument("--ki", type=float, default=1e-3)
    parser.add_argument("--most", type=float, default=0.02)
    args = parser.parse_args()

    hello = json.loads(sys.stdin.readline())
    if args.column not in hello["columns"]:
        sys.exit(f"the scene records no {args.column}")
    signal = hello["signals"][0]
    integral = hello["memory"] or 0.0
    answer(ready=True)

    for line in sys.stdin:
        seen = json.loads(line)
        if "end" in seen:
            break
        columns = seen["columns"]
        error = args.goal - columns[args.column]
        step = seen["next_s"] - columns["t_s"]
        value = args.kp * error + args.ki * (integral + error * step)
        # The integral rests while the signal is at its limit
        if 0.0 <= value <= args.most:
            integral += error * step
        answer(signals={signal: min(max(value, 0.0), args.most)}, memory=integral)


if __name__ == "__main__":
    main()
