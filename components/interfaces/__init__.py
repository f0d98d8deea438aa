"""The contract: quantities, records, blocks and sockets, independent of FMI, files and Rerun."""
