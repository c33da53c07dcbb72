"""What every part uses: errors, files, text."""
