"""Files and folders that appear whole or not at all, in the place of nothing that is a person's.

    new_file, new_folder       written aside, made durable, then put into place in one step
    check_new_file, _folder    the same refusals, before any work is spent
    found_again                the earlier result, where a writer was killed while replacing it

Each folder lists what was written and its hashes (`manifest`), so that a later run replaces that
and nothing else. What a killed run leaves has names of its own (`leftovers`), which the next one
puts back or clears away.
"""

from bodyschema.atomic.file import check_new_file as check_new_file
from bodyschema.atomic.file import new_file as new_file
from bodyschema.atomic.folder import check_new_folder as check_new_folder
from bodyschema.atomic.folder import new_folder as new_folder
from bodyschema.atomic.leftovers import found_again as found_again
