"""``python -m endocal`` is the command ``endocal``."""

from .cli.app import main

main()
