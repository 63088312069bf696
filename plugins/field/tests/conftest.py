"""What these tests share."""

from fixtures import command as command, data_dir as data_dir, install as install, moody as moody
