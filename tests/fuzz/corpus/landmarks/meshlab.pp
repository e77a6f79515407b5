<!DOCTYPE PickedPoints>
<PickedPoints>
 <DocumentData>
  <User name="s"/>
 </DocumentData>
 <!-- c -->
 <point name="Rh&amp;" x="4.8" active="1" y="17" z="3"/>
 <point x="0" y="0" z="0" active="0" name="unset"/>
</PickedPoints>
