"""System Structure and Parameterization (SSP): systems as files, ours and those of other makers."""
