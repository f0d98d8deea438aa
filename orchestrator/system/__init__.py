"""Systems: units, sources, connections, scene and experiment, checked completely before anything runs."""
