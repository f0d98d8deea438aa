"""The contract: quantities, records, blocks and the three sockets. It knows nothing of FMI, files or Rerun."""
