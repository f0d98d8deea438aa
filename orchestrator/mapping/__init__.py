"""Foreign FMUs behind our sockets: names, units, conventions and reference points."""
