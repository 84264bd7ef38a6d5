"""`python -m thermoroll_cli` is the command `thermoroll`."""

import signal


def main() -> None:
    """The process `thermoroll`."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        # From here on, and outside of commands, an interrupt ends the process as other signals do, without a trace.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from thermoroll_cli.cli.main import program

    program()


if __name__ == "__main__":
    main()
