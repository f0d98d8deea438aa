"""Exchange with other tools: checks of their files, and systems written for them."""
