"""`python -m wroll_fem.cli` is the command `wroll`."""

from wroll_fem.cli import main

main()
