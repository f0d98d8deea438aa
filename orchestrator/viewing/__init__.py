"""What a person sees of a run in the Rerun viewer."""
