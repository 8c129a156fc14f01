"""``python -m musclewire``."""

from musclewire.app import main

main()
