"""Puts cases/ into the wheel, for `thermoroll init --example`; all else is in pyproject.toml."""

from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py


class WithCases(build_py):
    def run(self) -> None:
        super().run()
        if not self.editable_mode:
            folder = Path(self.build_lib) / "thermoroll_cli" / "cases"
            folder.mkdir(parents=True, exist_ok=True)
            for path in Path("cases").iterdir():
                self.copy_file(str(path), str(folder / path.name))


setup(cmdclass={"build_py": WithCases})
