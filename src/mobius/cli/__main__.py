"""``python -m mobius.cli``."""

from mobius.cli import entry

if __name__ == "__main__":
    entry()
