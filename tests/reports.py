"""A progress that keeps what it is told."""

from __future__ import annotations


class Reports:
    """Keeps what is reported, in order."""

    def __init__(self):
        self.texts = []

    def now(self, text):
        self.texts.append(text)

    def done(self, text):
        self.texts.append(text)
