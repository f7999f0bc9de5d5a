"""`python -m wroll_fem.cli`: the command `wroll`."""

from wroll_fem.cli import main

main()
