"""Flash the board, and make the file that its boot loader takes."""
