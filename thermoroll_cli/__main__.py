"""`python -m thermoroll_cli` is the command `thermoroll`."""

from thermoroll_cli.cli.main import program

if __name__ == "__main__":
    program()
