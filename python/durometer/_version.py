"""The version of these files; the library must have the same."""

VERSION = "0.1.0"
