"""``python -m musclewire``."""

from musclewire.app.main import main

main()
