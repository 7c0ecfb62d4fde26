"""Pages for people: data in, one self-contained HTML text out; nothing here touches a file."""
