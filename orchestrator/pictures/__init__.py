"""Pictures: what is drawn of a run, as plain shapes and figures."""
