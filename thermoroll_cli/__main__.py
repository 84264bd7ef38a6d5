"""`python -m thermoroll_cli` is the command `thermoroll`."""

import sys

from thermoroll_cli.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
