"""What guided warps are compared with: what else a person could do."""
