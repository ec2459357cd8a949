"""Where a fit starts: closed forms and global searches."""
