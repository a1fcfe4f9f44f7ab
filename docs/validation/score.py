"""Scores predictions with 95 % intervals against measured values.

Usage: score.py PREDICTIONS.toml MEASURED.csv

MEASURED has the columns record, quantity, value. Rows without a prediction and predictions without a row are named.
"""

import csv
import math
import sys
import tomllib

ALPHA = 0.05


def interval_score(low: float, high: float, value: float) -> float:
    """Gneiting & Raftery 2007, Eq. 43."""
    return high - low + 2 / ALPHA * (max(low - value, 0.0) + max(value - high, 0.0))


def main(predictions: str, measured: str) -> int:
    with open(predictions, "rb") as file:
        predicted = {(p["record"], p["quantity"]): p for p in tomllib.load(file)["prediction"]}
    with open(measured, newline="", encoding="utf-8") as file:
        values = {(r["record"], r["quantity"]): float(r["value"]) for r in csv.DictReader(file)}
    for key in sorted(values.keys() - predicted.keys()):
        print(f"no prediction of {key[1]} of {key[0]}")
    for key in sorted(predicted.keys() - values.keys()):
        print(f"no measured value of {key[1]} of {key[0]}")
    both = sorted(values.keys() & predicted.keys())
    print(f"{'quantity':16} {'inside':>9} {'width':>10} {'score':>10} {'rms error':>10}")
    for quantity in sorted({q for _, q in both}):
        rows = [(predicted[key], values[key]) for key in both if key[1] == quantity]
        n = len(rows)
        inside = sum(p["low"] <= v <= p["high"] for p, v in rows)
        width = sum(p["high"] - p["low"] for p, _ in rows) / n
        score = sum(interval_score(p["low"], p["high"], v) for p, v in rows) / n
        rms = math.sqrt(sum((p["value"] - v) ** 2 for p, v in rows) / n)
        print(f"{quantity:16} {inside:4} of {n:2} {width:10.3f} {score:10.3f} {rms:10.3f}")
    return 0 if both else 1


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2]))
