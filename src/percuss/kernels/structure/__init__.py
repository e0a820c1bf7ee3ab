"""The motion of several masses between stops: the scalar family's questions, for n modes."""
