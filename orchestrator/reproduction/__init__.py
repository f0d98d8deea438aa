"""All experiments of the paper, run and judged by one command."""
