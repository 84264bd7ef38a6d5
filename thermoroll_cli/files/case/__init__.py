"""Case files: from TOML text to a problem in SI units, with errors that name place and remedy."""
