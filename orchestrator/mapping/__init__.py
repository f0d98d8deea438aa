"""FMUs of other makers behind sockets: names, units of measurement, conventions and reference points.

Throughout, *ours* are the signals of a socket and *theirs* the variables of the FMU that is to fill it.
"""
