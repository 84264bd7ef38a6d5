"""The figures and measured tables of docs/: `make figures`."""
